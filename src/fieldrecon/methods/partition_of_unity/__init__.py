"""partition_of_unity."""
