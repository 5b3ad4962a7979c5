-- A machine without physics: toothed wheels turn by what their teeth count, and a crank drives a rod. Every part
-- hangs in a hierarchy, so that each is told its own motion alone.
kandil.scene { size = {640, 360}, fps = 24, seconds = 4 }

local MODULE = 0.05 -- pitch diameter over teeth

local function gear(name, teeth, position, color)
    local radius = MODULE * teeth / 2
    local wheel = kandil.spawn { name = name, transform = { position = position } }
    kandil.spawn {
        parent = wheel,
        mesh = { shape = "cylinder", size = {2 * radius - MODULE, 0.16, 0}, segments = 48 },
        material = { base_color = color, metallic = 1, roughness = 0.35 },
        transform = { rotation_deg = {90, 0, 0} },
    }
    for i = 0, teeth - 1 do
        local a = 2 * math.pi * i / teeth
        kandil.spawn {
            parent = wheel,
            mesh = { shape = "box", size = {2.2 * MODULE, 1.3 * MODULE, 0.16} },
            material = { base_color = color, metallic = 1, roughness = 0.35 },
            transform = { position = {radius * math.cos(a), radius * math.sin(a), 0}, rotation_deg = {0, 0, math.deg(a)} },
        }
    end
    return { wheel = wheel, teeth = teeth, radius = radius }
end

kandil.spawn { mesh = { shape = "box", size = {9, 5, 0.1} }, material = { base_color = {0.25, 0.32, 0.36} },
               transform = { position = {0, 1.2, -0.3} } }
kandil.spawn { mesh = { shape = "box", size = {9, 0.1, 3} }, material = { base_color = {0.5, 0.45, 0.4} },
               transform = { position = {0, -0.05, 1.1} } }

local big = gear("big", 24, {-0.55, 1.1, 0}, {0.95, 0.64, 0.3})
local small = gear("small", 12, {-0.55 + 0.05 * 18, 1.1, 0}, {0.75, 0.78, 0.85})

-- The crank: a pin on the small wheel, a rod from it, a piston that stays on its line.
local PIN, ROD = 0.2, 0.75
kandil.spawn { parent = small.wheel, mesh = { shape = "cylinder", size = {0.08, 0.3, 0} },
               material = { base_color = {0.8, 0.8, 0.8}, metallic = 1, roughness = 0.3 },
               transform = { position = {PIN, 0, 0.15}, rotation_deg = {90, 0, 0} } }
local rod = kandil.spawn { mesh = { shape = "box", size = {ROD, 0.07, 0.05} },
                           material = { base_color = {0.75, 0.2, 0.15}, roughness = 0.5 } }
local piston = kandil.spawn { mesh = { shape = "box", size = {0.3, 0.22, 0.22} },
                              material = { base_color = {0.2, 0.35, 0.6}, roughness = 0.4 } }

kandil.spawn { light = { type = "directional", color = {1, 0.92, 0.8}, intensity = 3 }, transform = { look_at = {0.6, -0.9, -0.8} } }
kandil.spawn { sky = { intensity = 0.8 } }
kandil.spawn { camera = { fov_y_deg = 38 }, transform = { position = {1.3, 1.5, 2.7}, look_at = {0.22, 1, 0} } }

function kandil.update(t)
    local turn = 45 * t -- degrees, of the big wheel
    local small_turn = -turn * big.teeth / small.teeth + 180 / small.teeth
    big.wheel.transform.rotation_deg = {0, 0, turn}
    small.wheel.transform.rotation_deg = {0, 0, small_turn}
    local a, hub = math.rad(small_turn), small.wheel.transform.position
    local x, y = hub[1] + PIN * math.cos(a), hub[2] + PIN * math.sin(a)
    local reach = math.sqrt(ROD * ROD - (y - hub[2]) ^ 2)
    piston.transform.position = {x + reach, hub[2], 0.3}
    rod.transform.position = {x + reach / 2, (y + hub[2]) / 2, 0.3}
    rod.transform.rotation_deg = {0, 0, math.deg(math.atan(hub[2] - y, reach))}
end
