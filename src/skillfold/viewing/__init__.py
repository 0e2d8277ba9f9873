"""Pictures: matplotlib plots."""
