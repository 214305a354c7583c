"""The estimator's side: what runs in processes of its own, and the messages that come and go."""
