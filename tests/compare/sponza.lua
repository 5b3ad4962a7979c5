-- Down the atrium: the sun falls in steeply, most of what is seen is in shade.
-- Four cascades reach its end, and narrow cones find the sky between its walls.
kandil.scene { size = {320, 180}, exposure_ev = 2.5, ambient = 0.3,
               settings = { ["voxels.span"] = 0.03, ["voxels.resolution"] = 256, ["voxels.cascades"] = 4,
                            ["cones.far"] = 0.25 } }
kandil.spawn { model = "sponza/sponza.glb" }
kandil.spawn { light = { type = "directional", intensity = 8 }, transform = { look_at = {0.18, -1, 0.28} } }
kandil.spawn { camera = { fov_y_deg = 55 },
               transform = { position = {-10.5, 1.9, -0.4}, look_at = {4, 3.2, 0.2} } }
