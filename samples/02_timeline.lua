-- Clips on a timeline: the dragon looks around, jumps for joy, and walks on.
kandil.scene { size = {640, 360}, fps = 24, seconds = 5 }

kandil.spawn { model = "assets/cornell.gltf" }
local walker = kandil.spawn { model = "assets/walker.gltf", animation = { clip = "idle", loop = true } }

kandil.spawn { light = { type = "point", intensity = 6 }, transform = { position = {-0.3, 1.8, 0.7} } }
kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0.55, 0.8, 2}, look_at = {0, 0.6, 0} } }

kandil.at(2, function() walker:play("jump", { blend = 0.1 }) end)
kandil.at(3, function() walker:play("walk", { blend = 0.1 }) end)
