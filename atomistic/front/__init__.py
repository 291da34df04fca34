"""Public functions of ``atomistic``, and the commands made from them."""
