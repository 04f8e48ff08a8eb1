"""What is made of the logs of eight simulated machines, by us and others."""
