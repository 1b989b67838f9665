"""Pictures and pages: what a scene file asks, computed, drawn and written."""
