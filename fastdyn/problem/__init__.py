"""What the user asked for, checked: equations, spans, options."""
