"""The grammar of formats, and the codecs made from it; pure."""
