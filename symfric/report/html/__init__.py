"""Parts of HTML pages: equations, versions, galleries, ticks."""
