"""Lagrangia: a Modelica-style language for mechanics, with a compiler."""
