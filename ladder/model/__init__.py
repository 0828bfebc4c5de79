"""What a program is made of: types, tags, tree, expressions, operands, one instruction."""
