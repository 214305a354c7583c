"""Drawing: the scene is a function of the View."""
