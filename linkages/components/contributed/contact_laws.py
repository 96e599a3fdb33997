"""Laws of contact by their names: those of files in `linkages.components.contacts`."""

from __future__ import annotations

from typing import Annotated

from linkages.components.contributed.law_names import LawName, laws_in
from linkages.components.contributed.normal_laws import ContactLaw

GROUP = "linkages.components.contacts"
"""Entry points that name laws of contact, and the folder of those of this package."""


def contact_laws() -> dict[str, ContactLaw]:
    """All laws by their names."""
    return laws_in(GROUP)


ContactName = Annotated[str, LawName(GROUP, "a law of contact")]
