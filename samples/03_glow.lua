-- Emissive surfaces light a room without any lamp: two glowing balls circle in the dark box.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4, gi = "cones", exposure_ev = 2 }

kandil.spawn { model = "assets/cornell.gltf" }
kandil.spawn { camera = { fov_y_deg = 40 }, transform = { position = {0, 1, 3.5}, look_at = {0, 0.95, 0} } }

local function glow(color)
    return kandil.spawn {
        mesh = { shape = "sphere", size = {0.3, 0.3, 0.3} },
        material = { base_color = {0, 0, 0}, emissive = color },
    }
end
local warm, cold = glow {6, 3, 0.9}, glow {1.2, 3, 6}

function kandil.update(t)
    local a = math.pi * t / 2
    local x, y = 0.5 * math.cos(a), 0.3 * math.sin(2 * a)
    warm:set("transform.position", {x, 1 + y, 0.5 * math.sin(a)})
    cold:set("transform.position", {-x, 1 - y, -0.5 * math.sin(a)})
end
