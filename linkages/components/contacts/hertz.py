"""H. Hertz, *J. reine angew. Math.* 92 (1881) 156: an elastic contact of two spheres."""

from linkages.components.contributed.normal_laws import elastic_law

LAW = elastic_law("hertz")
