"""What a person calls: the public functions of ``atomistic``, and the commands made from them."""
