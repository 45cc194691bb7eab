"""Other methods for the statics of a limb, written plainly from the same equations, to compare with."""
