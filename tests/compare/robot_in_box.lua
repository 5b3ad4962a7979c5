-- A robot walks between the blocks of the Cornell box, in a spot light and in that of the lamp.
kandil.scene { size = {256, 256}, fps = 24, seconds = 1, settings = { ["voxels.span"] = 0.0055 } }
kandil.spawn { model = "cornell_box/cornell_box.glb" }
kandil.spawn { model = "robot/robot.glb", animation = { clip = "Robot_Walking", loop = true },
               transform = { position = {0.4, 0, 0.12}, rotation_deg = {0, 200, 0}, scale = {0.05, 0.05, 0.05} } }
kandil.spawn { light = { type = "spot", intensity = 1.2, inner_cone_deg = 20, outer_cone_deg = 40 },
               transform = { position = {0.278, 0.53, 0.1}, look_at = {0.278, 0, 0.3} } }
