-- The smallest scenario: a box on a floor, a sun, a sky, a camera.
kandil.scene { size = {640, 360}, fps = 24, seconds = 2 }

kandil.spawn { mesh = { shape = "plane", size = {40, 1, 40} }, material = { base_color = {0.4, 0.42, 0.45} } }

local box = kandil.spawn {
    name = "box",
    mesh = { shape = "box", size = {0.6, 0.6, 0.6} },
    material = { base_color = {0.8, 0.25, 0.1}, roughness = 0.6 },
    transform = { position = {0, 0.3, 0} },
}

kandil.spawn {
    light = { type = "directional", intensity = 3 },
    transform = { look_at = {-0.9, -0.8, -0.25} },
}
kandil.spawn { sky = { intensity = 0.35 } }

kandil.spawn {
    camera = { fov_y_deg = 40 },
    transform = { position = {0.6, 0.9, 1.9}, look_at = {0, 0.3, 0} },
}

function kandil.update(t)
    box:set("transform.rotation_deg", {0, 90 * t, 0})
end
