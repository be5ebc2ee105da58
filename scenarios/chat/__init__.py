"""Language models behind an address that the user names, asked by OpenAI's chat/completions API."""
