-- Materials: rough to smooth from left to right, plastic in front and metal behind.
kandil.scene { size = {640, 360}, fps = 24, seconds = 2 }

kandil.spawn { mesh = { shape = "box", size = {8, 0.1, 6} }, material = { base_color = {0.6, 0.6, 0.6}, roughness = 0.9 },
               transform = { position = {0, -0.05, 0} } }
kandil.spawn { mesh = { shape = "box", size = {8, 3, 0.1} }, material = { base_color = {0.15, 0.35, 0.7} },
               transform = { position = {0, 1.5, -1.6} } }
kandil.spawn { mesh = { shape = "box", size = {0.1, 3, 3.2} }, material = { base_color = {0.8, 0.3, 0.1} },
               transform = { position = {-2.6, 1.5, 0} } }

for i = 0, 4 do
    local roughness = 1 - i / 4 * 0.95
    kandil.spawn {
        name = "plastic" .. i,
        mesh = { shape = "sphere", size = 0.7 },
        material = { base_color = {0.75, 0.1, 0.1}, roughness = roughness },
        transform = { position = {-1.8 + 0.9 * i, 0.35, 0.6} },
    }
    kandil.spawn {
        name = "metal" .. i,
        mesh = { shape = "sphere", size = 0.7 },
        material = { base_color = {1, 0.78, 0.34}, metallic = 1, roughness = roughness },
        transform = { position = {-1.8 + 0.9 * i, 0.35, -0.5} },
    }
end

kandil.spawn { light = { type = "directional", intensity = 2.5 }, transform = { look_at = {-0.5, -1, -0.7} } }
kandil.spawn { camera = { fov_y_deg = 38 }, transform = { position = {0.3, 1.7, 4.4}, look_at = {0, 0.4, 0} } }
