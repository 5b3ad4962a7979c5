-- A crowd: one model, many skinned characters, each with a clip, a speed and a phase of its own.
-- `--set param.rows=8` makes it 64.
kandil.scene { size = {640, 360}, fps = 24, seconds = 3, settings = { ["voxels.span"] = 0.03 } }

local rows = kandil.param("rows", 4)
kandil.spawn { mesh = { shape = "box", size = {60, 0.1, 60} }, material = { base_color = {0.55, 0.5, 0.35} },
               transform = { position = {0, -0.05, 0} } }
for i = 0, rows * rows - 1 do
    local x, z = i % rows - (rows - 1) / 2, i // rows - (rows - 1) / 2
    local walker = kandil.spawn {
        name = "walker" .. i,
        model = "assets/walker.gltf",
        animation = { clip = i % 3 == 0 and "walk" or i % 3 == 1 and "jump" or "idle", loop = true },
        transform = { position = {0.9 * x, 0, 0.9 * z}, rotation_deg = {0, math.random(-40, 40), 0} },
    }
    walker.animation.time_s = math.random()
    walker.animation.speed = 0.8 + 0.4 * math.random()
end
kandil.spawn { light = { type = "directional", intensity = 3 }, transform = { look_at = {-0.7, -0.7, -0.5} } }
kandil.spawn { sky = { intensity = 0.7 } }
kandil.spawn { camera = { fov_y_deg = 34 }, transform = { position = {1.3, 1.35, 4.4}, look_at = {0, 0.5, 0} } }
