-- The smallest scenario: a box on a floor, one light, one camera.
kandil.scene { size = {640, 360}, fps = 24, seconds = 2 }

kandil.spawn { mesh = { shape = "plane", size = {6, 1, 6} }, material = { base_color = {0.7, 0.7, 0.7} } }

local box = kandil.spawn {
    name = "box",
    mesh = { shape = "box", size = {0.6, 0.6, 0.6} },
    material = { base_color = {0.8, 0.25, 0.1}, roughness = 0.6 },
    transform = { position = {0, 0.3, 0} },
}

kandil.spawn {
    light = { type = "directional", intensity = 3 },
    transform = { look_at = {-0.4, -1, -0.5} },
}

kandil.spawn {
    camera = { fov_y_deg = 40 },
    transform = { position = {1.4, 1.2, 2.2}, look_at = {0, 0.3, 0} },
}

function kandil.update(t)
    box:set("transform.rotation_deg", {0, 90 * t, 0})
end
