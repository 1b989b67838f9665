"""Design of a contact that brakes a rod."""
