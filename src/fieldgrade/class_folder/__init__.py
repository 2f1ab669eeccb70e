"""class_folder."""
