-- A camera on a path: a smooth curve through points, walked at constant speed with a soft start and end, the eye on
-- the middle of the creature.
kandil.scene { size = {640, 360}, fps = 24, seconds = 5 }

kandil.spawn { model = "assets/cornell.gltf" }
local walker = kandil.spawn {
    name = "walker",
    model = "assets/walker.gltf",
    animation = { clip = "idle", loop = true },
}
kandil.spawn { light = { type = "point", intensity = 5 }, transform = { position = {-0.3, 1.8, 0.5} } }
local gaze = kandil.spawn { transform = { position = {0, 0.55, 0} } } -- what the eye is on: a place may be an entity
local camera = kandil.spawn { name = "camera", camera = { fov_y_deg = 45 } }

local way = kandil.path { {-0.8, 0.4, 2.4}, {-0.5, 1.4, 1.6}, {0.6, 1, 1.3}, {0.7, 0.75, 0.75} }
kandil.run(function()
    kandil.wait(kandil.follow(camera, way, 4, { easing = "sine_inout", look_at = gaze }))
    walker:play("jump", { blend = 0.1 })
end)
