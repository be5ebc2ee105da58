"""Which addresses a key may go to; what an answer may be is tested where it is read."""

from scenarios.chat.completions import address_of, is_private


def test_a_key_is_not_sent_in_the_clear_to_another_machine():
    private = [
        "https://example.org/v1",
        "http://127.0.0.1:1/v1",
        "http://[::1]/",
        "http://localhost",
    ]
    assert all(is_private(address_of(each, "endpoint")) for each in private)
    assert not is_private(address_of("http://example.org/v1", "endpoint"))
    assert not is_private(address_of("http://127.0.0.1.example.org/v1", "endpoint"))
