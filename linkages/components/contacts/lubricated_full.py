"""A short journal bearing with a film all around that bears tension, as under high pressure."""

from linkages.components.contributed.normal_laws import film_law

LAW = film_law("lubricated-full", whole=True)
