"""Scenes in space as they are seen: solids and lines over time, on paper, in pages that are turned by hand, as glTF.

Here belongs: what solids are made of, cameras, files of pictures of scenes in space (shapes -> stage -> camera, orbit, gltf).
Not here: pictures of the plane and players of any motion (draw).
"""
