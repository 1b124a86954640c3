"""How exactly the compiled plant follows its equations: a campaign over random rigs."""
