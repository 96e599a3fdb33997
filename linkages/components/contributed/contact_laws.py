"""Laws of contact by their names: those of files in `linkages.components.contacts`."""

from __future__ import annotations

from functools import cache
from typing import Annotated, Any

from linkages.components.contributed.contacts import ContactLaw
from linkages.discovery import modules_of, plugged
from linkages.reading.wording import listed, shown, suggestion
from linkages.spec.conversion import QuantityError
from linkages.spec.quantities import FieldType

GROUP = "linkages.components.contacts"
"""Entry points that name laws of contact, and the folder of those of this package."""


@cache
def contact_laws() -> dict[str, ContactLaw]:
    """All laws by their names."""
    own = [module.LAW for module in modules_of(GROUP)]
    return {law.name: law for law in (*own, *(law for _, law in plugged(GROUP)))}


class ContactRule(FieldType):
    """The name of a law of contact."""

    def read(self, value: Any) -> str:
        """Return the name."""
        if value not in contact_laws():
            near = suggestion(str(value), contact_laws())
            raise QuantityError(self.expected(), f"{shown(value)}{near}")
        return str(value)

    def expected(self) -> str:
        """Return the names."""
        return f"a law of contact ({listed(contact_laws())})"

    def json_schema(self) -> dict[str, Any]:
        """Return the names."""
        return {"enum": list(contact_laws())}


ContactName = Annotated[str, ContactRule()]
