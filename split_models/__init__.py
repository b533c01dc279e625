"""The models of the SPLIT paper and the baselines it compares with; they read and write tactiledata stores."""
