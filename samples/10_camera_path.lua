-- A camera on a path: a smooth curve through points, walked at constant speed with a soft start and end, the eye on
-- the creature.
kandil.scene { size = {640, 360}, fps = 24, seconds = 5 }

kandil.spawn { model = "assets/cornell.gltf" }
local walker = kandil.spawn {
    name = "walker",
    model = "assets/walker.gltf",
    animation = { clip = "idle", loop = true },
}
kandil.spawn { light = { type = "point", intensity = 10 }, transform = { position = {0, 1.8, 0.4} } }
local camera = kandil.spawn { name = "camera", camera = { fov_y_deg = 45 } }

local way = kandil.path { {-1.6, 0.5, 2.6}, {-0.4, 1.5, 2.1}, {0.7, 0.9, 1.4}, {0.65, 0.5, 0.4} }
kandil.run(function()
    kandil.wait(kandil.follow(camera, way, 4, { easing = "sine_inout", look_at = walker:child("head") or walker }))
    walker:play("jump", { blend = 0.1 })
end)
