"""The forms of sliding friction that ``friction.form`` chooses from."""
