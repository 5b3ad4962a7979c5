-- The three kinds of lights: a low sun, a point light that circles, a spot that searches. Each casts shadows and bounces.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4, exposure_ev = 1 }

kandil.spawn { mesh = { shape = "box", size = {8, 0.1, 8} }, material = { base_color = {0.75, 0.75, 0.72} },
               transform = { position = {0, -0.05, 0} } }
kandil.spawn { mesh = { shape = "box", size = {8, 4, 0.1} }, material = { base_color = {0.7, 0.6, 0.5} },
               transform = { position = {0, 2, -2} } }
for i = -2, 2 do
    kandil.spawn {
        mesh = { shape = "cylinder", size = {0.3, 1.2, 0.3} },
        material = { base_color = {0.8, 0.8, 0.8} },
        transform = { position = {0.9 * i, 0.6, -0.6 - 0.3 * (i % 2)} },
    }
end

kandil.spawn {
    name = "sun",
    light = { type = "directional", color = {1, 0.7, 0.4}, intensity = 0.8 },
    transform = { look_at = {-1, -0.5, -0.6} },
}
local lamp = kandil.spawn {
    name = "lamp",
    mesh = { shape = "sphere", size = 0.1 },
    material = { base_color = {0, 0, 0}, emissive = {2, 4, 8} },
    mesh_instance = { no_shadow = true },
    light = { type = "point", color = {0.4, 0.7, 1}, intensity = 1.6 },
}
local spot = kandil.spawn {
    name = "spot",
    light = { type = "spot", color = {1, 0.35, 0.3}, intensity = 30, inner_cone_deg = 12, outer_cone_deg = 20 },
    transform = { position = {2.2, 2.2, 1.4} },
}
kandil.spawn { camera = { fov_y_deg = 36 }, transform = { position = {0.4, 1.5, 3.9}, look_at = {0, 0.65, -0.6} } }

function kandil.update(t)
    local a = math.pi / 2 * t
    lamp.transform.position = {1.5 * math.sin(a), 0.5, 0.6 + 0.5 * math.cos(a)}
    spot:look_at({1.6 * math.sin(a * 0.7 + 2), 0.4, -1})
end
