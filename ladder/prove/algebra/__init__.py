"""Terms: truths, whole numbers and floats, what they mean, and many values of them at once."""
