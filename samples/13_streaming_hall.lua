-- A hall longer than the voxels reach: the camera flies along it, bays come into the cascades and leave them. What
-- stands still is voxelized once; only what the cascades uncover is touched.
kandil.scene {
    size = {640, 360}, fps = 24, seconds = 5,
    settings = { ["voxels.span"] = 0.05, ["voxels.resolution"] = 128, ["voxels.cascades"] = 3 },
}

local bays = kandil.param("bays", 24)
local LENGTH = 4

local function part(shape, size, position, color)
    kandil.spawn { mesh = { shape = shape, size = size }, material = { base_color = color },
                   transform = { position = position } }
end
for i = 0, bays - 1 do
    local z = -LENGTH * i
    local warm = i % 2 == 0 and {0.75, 0.3, 0.2} or {0.25, 0.4, 0.7}
    part("box", {8, 0.2, LENGTH}, {0, -0.1, z}, {0.6, 0.58, 0.55})
    part("box", {0.2, 4, LENGTH}, {-4, 2, z}, {0.7, 0.68, 0.64})
    part("box", {0.2, 4, LENGTH}, {4, 2, z}, {0.7, 0.68, 0.64})
    part("box", {8.2, 0.2, LENGTH * 0.55}, {0, 4.1, z}, {0.7, 0.68, 0.64}) -- the rest of the ceiling is open
    for _, x in ipairs { -2.4, 2.4 } do
        part("cylinder", {0.5, 3.4, 0}, {x, 1.7, z}, {0.8, 0.78, 0.72})
        part("box", {0.9, 0.4, 0.9}, {x, 3.8, z}, {0.8, 0.78, 0.72})
    end
    part("box", {0.1, 1.4, 1}, {-3.8, 2, z}, warm)
    part("box", {0.1, 1.4, 1}, {3.8, 2, z}, warm)
end

kandil.spawn { light = { type = "directional", color = {1, 0.95, 0.85}, intensity = 8 }, transform = { look_at = {0.35, -1, -0.25} } }
kandil.set("light.ambient", 0.25)
local camera = kandil.spawn { name = "camera", camera = { fov_y_deg = 55 } }

function kandil.update(t)
    local z = 2 - (LENGTH * bays - 12) * t / 5
    camera.transform.position = {0.8 * math.sin(t), 1.7, z}
    camera:look_at({0, 1.6, z - 4})
end
