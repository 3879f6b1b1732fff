"""The drive as a Gymnasium environment whose action is the blend weight k_s."""
