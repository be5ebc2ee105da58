"""Language models that the user names, asked over HTTP as OpenAI's servers are."""
