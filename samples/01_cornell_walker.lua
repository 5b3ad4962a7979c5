-- The demo: a small dragon walks through a Cornell box, past the red and the green wall, while a metal ball turns and
-- a lamp swings. All light is dynamic; nothing is baked.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4, gi = "cones" }

kandil.spawn { name = "room", model = "assets/cornell.gltf" }

kandil.spawn {
    name = "camera",
    camera = { fov_y_deg = 40 },
    transform = { position = {0, 1, 3.3}, look_at = {0, 0.93, 0} },
}

-- The dragon. Its walk carries the feet at 0.4 m/s: moved at this speed they do not slide.
local walk_speed = 0.4
local start = {-0.62, 0, -0.60}
local walker = kandil.spawn {
    name = "walker",
    model = "assets/walker.gltf",
    animation = { clip = "walk", loop = true },
    transform = { position = start, rotation_deg = {0, 5, 0} },
}

-- Its heading at some times, in degrees: 0 is towards the camera, 90 towards the green wall.
local headings = { {0, 5}, {1.0, 15}, {2.0, 75}, {2.6, 70}, {3.6, -15}, {4.0, -15} }

local function heading_at(t)
    for i = 2, #headings do
        local a, b = headings[i - 1], headings[i]
        if t < b[1] then
            local s = (t - a[1]) / (b[1] - a[1])
            return a[2] + (b[2] - a[2]) * s * s * (3 - 2 * s)
        end
    end
    return headings[#headings][2]
end

-- The metal ball, with knobs that show how it turns: children follow their parent.
local ball = kandil.spawn {
    name = "ball",
    mesh = { shape = "sphere", size = {0.5, 0.5, 0.5} },
    material = { base_color = {0.95, 0.90, 0.80}, metallic = 1, roughness = 0.2 },
    transform = { position = {0.60, 0.27, -0.45} },
}
for i = 0, 5 do
    local a = i * math.pi / 3
    kandil.spawn {
        parent = ball,
        mesh = { shape = "sphere", size = {0.11, 0.11, 0.11} },
        material = { base_color = i % 2 == 0 and {0.10, 0.30, 0.80} or {0.90, 0.75, 0.10}, roughness = 0.5 },
        transform = { position = {0.25 * math.cos(a), 0.06 * (i % 2 == 0 and 1 or -1), 0.25 * math.sin(a)} },
    }
end

-- The lamp hangs from a hook that rolls along the ceiling: a shade, a bulb that glows, and the light itself.
local hook = kandil.spawn { name = "hook", transform = { position = {0, 1.98, 0.25} } }
kandil.spawn {
    name = "cord",
    parent = hook,
    mesh = { shape = "box", size = {0.02, 0.30, 0.02} },
    material = { base_color = {0.05, 0.05, 0.05} },
    transform = { position = {0, -0.15, 0} },
}
kandil.spawn {
    name = "bulb",
    parent = hook,
    mesh = { shape = "sphere", size = {0.12, 0.12, 0.12} },
    material = { base_color = {1, 1, 1}, emissive = {8, 6.6, 4.6} },
    transform = { position = {0, -0.34, 0} },
}
kandil.spawn { -- below the bulb, so that the bulb does not shadow it; a light shines along its own -z
    name = "lamp",
    parent = hook,
    light = {
        type = "spot", color = {1, 0.88, 0.68}, intensity = 16, range = 6,
        inner_cone_deg = 40, outer_cone_deg = 80,
    },
    transform = { position = {0, -0.42, 0}, rotation_deg = {-90, 0, 0} },
}

local x, z = start[1], start[3]

function kandil.update(t, dt)
    local heading = heading_at(t)
    walker:set("transform.position", {x, 0, z})
    walker:set("transform.rotation_deg", {0, heading, 0})
    x = x + walk_speed * dt * math.sin(math.rad(heading))
    z = z + walk_speed * dt * math.cos(math.rad(heading))

    ball:set("transform.rotation_deg", {12, 120 * t, 0})

    hook:set("transform.position", {0.30 * math.sin(math.pi * t / 2), 1.98, 0.25})
    hook:set("transform.rotation_deg", {6 * math.sin(math.pi * t), 0, 14 * math.cos(math.pi * t)})
end
