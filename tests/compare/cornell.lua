-- The Cornell box as it was measured, seen by its own camera and lit by its lamp alone.
kandil.scene { size = {256, 256}, settings = { ["voxels.span"] = 0.0055, ["cones.far"] = 0.65 } }
kandil.spawn { model = "cornell_box/cornell_box.glb" }
