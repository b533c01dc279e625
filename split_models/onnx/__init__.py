"""Networks for programs without PyTorch."""
