"""The program model: types, tags, the tree, expressions, operands, instruction specs."""
