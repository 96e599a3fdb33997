"""The same question asked at many values of parameters: diagrams and maps."""
