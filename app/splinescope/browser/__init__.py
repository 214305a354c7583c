"""The page as a place: its server and channel, camera, visitors, links and what a browser keeps."""
