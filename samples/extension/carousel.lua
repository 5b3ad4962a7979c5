-- Boxes on a turning disc. `spin` and `vignette` are components of carousel.c, not of Kandil.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4 }

kandil.spawn { mesh = { shape = "plane", size = {8, 1, 8} }, material = { base_color = {0.7, 0.7, 0.7} } }

local disc = kandil.spawn {
    name = "disc",
    mesh = { shape = "box", size = {2.4, 0.1, 2.4} },
    material = { base_color = {0.5, 0.5, 0.55} },
    transform = { position = {0, 0.3, 0} },
    spin = { turns_per_s = 0.25 },
}
for i = 1, 5 do
    local a = 2 * math.pi * i / 5
    kandil.spawn {
        name = "box" .. i,
        parent = disc,
        mesh = { shape = "box", size = {0.35, 0.35 + 0.08 * i, 0.35} },
        material = { base_color = {0.9, 0.15 * i, 0.1}, roughness = 0.6 },
        transform = { position = {0.85 * math.cos(a), 0.3, 0.85 * math.sin(a)} },
        spin = { axis = {0, 1, 0}, turns_per_s = -0.5 },
    }
end
kandil.spawn { name = "lens", vignette = { strength = 0.7 } }
kandil.spawn { light = { type = "directional", intensity = 3 }, transform = { look_at = {-0.5, -1, -0.4} } }
kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {2.2, 2.0, 3.2}, look_at = {0, 0.4, 0} } }
