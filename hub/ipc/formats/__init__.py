"""What both ends share of messages: the grammar of formats and the codecs made from it; pure."""
