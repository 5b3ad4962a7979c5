-- Materials: rough to smooth from left to right, plastic in the middle and metal behind; in front a coat of varnish over
-- metal, a stone of high refractive index, clear and tinted glass, and a glow.
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

local front = {
    { base_color = {0.1, 0.25, 0.6}, metallic = 0.7, roughness = 0.5, clearcoat = 1, clearcoat_roughness = 0.05 },
    { base_color = {0.05, 0.3, 0.15}, roughness = 0.1, ior = 2.4 },
    { base_color = {0.97, 0.98, 0.98}, roughness = 0.05, transmission = 1 },
    { base_color = {1, 0.65, 0.2}, roughness = 0.05, transmission = 1 },
    { base_color = {0.1, 0.1, 0.1}, emissive = {3, 1.4, 0.5} },
}
for i, material in ipairs(front) do
    kandil.spawn { mesh = { shape = "sphere", size = 0.4 }, material = material,
                   transform = { position = {-1.55 + 0.72 * (i - 1), 0.2, 1.35} } }
end

kandil.spawn { sky = { intensity = 0.5 } }
kandil.spawn { light = { type = "directional", intensity = 2.5 }, transform = { look_at = {-0.5, -1, -0.7} } }
kandil.spawn { camera = { fov_y_deg = 36 }, transform = { position = {0.2, 1.5, 4.4}, look_at = {-0.1, 0.36, 0.3} } }
