"""Maps: workspaces, margins over two coordinates, assembly modes side by side."""
