"""Any atoms that ASE knows, of any face and any potential: the wall as a calculator, the relaxation as an optimizer."""
