-- Two hundred lamps in a hall, for docs/benchmarks.md: direct light alone. A range of 0 is none.
kandil.scene { size = {640, 360}, fps = 24, seconds = 1, gi = "none" }
local range = kandil.param("range", 2)

kandil.spawn {
    name = "camera",
    camera = { fov_y_deg = 60 },
    transform = { position = {0, 2, 11}, look_at = {0, 1.5, 0} },
}

local function block(position, size, color)
    kandil.spawn {
        mesh = { shape = "box", size = size },
        material = { base_color = color, roughness = 0.6 },
        transform = { position = position },
    }
end

local white = {0.7, 0.7, 0.7}
block({0, -0.1, 0}, {16, 0.2, 30}, white)
block({0, 6.1, 0}, {16, 0.2, 30}, white)
block({0, 3, -15}, {16, 6, 0.2}, white)
block({-8, 3, 0}, {0.2, 6, 30}, {0.8, 0.5, 0.4})
block({8, 3, 0}, {0.2, 6, 30}, {0.4, 0.6, 0.8})
for i = -3, 3 do
    for side = -1, 1, 2 do
        block({side * 4, 3, i * 4}, {0.8, 6, 0.8}, white)
    end
end

for i = 0, 199 do
    local column, row = i % 10, i // 10
    kandil.spawn {
        name = "lamp" .. i,
        light = {
            type = "point",
            color = {0.5 + 0.5 * (i % 2), 0.5 + 0.25 * (i % 3), 0.5 + 0.125 * (i % 5)},
            intensity = 2,
            range = range,
            no_shadow = true,
        },
        transform = { position = {1.6 * column - 7.2, 0.5 + 1.3 * ((i * 7) % 5), 1.45 * row - 14} },
    }
end
