"""What geometric formats have in common: outlines of links with holes, and paths of joints."""
