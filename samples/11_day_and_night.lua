-- A day in eight seconds: the sun rises, crosses the sky and sets, the sky follows, and lamps come on at night.
kandil.scene { size = {640, 360}, fps = 24, seconds = 8, settings = { ["voxels.span"] = 0.03 } }

kandil.spawn { mesh = { shape = "box", size = {60, 0.1, 60} }, material = { base_color = {0.45, 0.5, 0.4} },
               transform = { position = {0, -0.05, 0} } }
local function house(x, z, color)
    kandil.spawn { mesh = { shape = "box", size = {1, 0.9, 1} }, material = { base_color = color },
                   transform = { position = {x, 0.45, z} } }
    kandil.spawn { mesh = { shape = "box", size = {0.7, 0.7, 0.98} }, material = { base_color = {0.6, 0.2, 0.15} },
                   transform = { position = {x, 0.92, z}, rotation_deg = {0, 0, 45} } }
    return kandil.spawn { mesh = { shape = "box", size = {0.25, 0.3, 0.04} },
                          material = { base_color = {0.1, 0.1, 0.1}, emissive = {3, 2.1, 0.9} },
                          transform = { position = {x, 0.5, z + 0.51} } }
end
local windows = { house(-1.4, -0.6, {0.85, 0.8, 0.7}), house(0.1, -1.1, {0.7, 0.75, 0.85}), house(1.5, -0.5, {0.85, 0.7, 0.7}) }

-- The same sky all day, brighter and darker: a factor costs nothing, another gradient is made anew.
local sky = kandil.spawn { sky = { zenith = {0.25, 0.4, 0.8}, horizon = {0.95, 0.75, 0.6} } }
local sun = kandil.spawn { name = "sun", light = { type = "directional", intensity = 3 } }
local lamp = kandil.spawn { name = "lamp", light = { type = "point", color = {1, 0.8, 0.5}, intensity = 3 },
                            transform = { position = {0.2, 1.1, 0.9} } }
kandil.spawn { mesh = { shape = "cylinder", size = {0.06, 1, 0} }, material = { base_color = {0.2, 0.2, 0.2} },
               transform = { position = {0.2, 0.5, 0.9} } }
kandil.spawn { camera = { fov_y_deg = 38 }, transform = { position = {0.7, 1.3, 4.6}, look_at = {0.1, 0.62, -0.3} } }

function kandil.update(t)
    local hour = t / 8 * 24 -- from midnight to midnight
    local a = math.pi * (hour - 6) / 12
    local height = math.sin(a)
    local day = math.max(0, math.min(1, height * 4 + 0.2))
    sun:look_at({-math.cos(a), -math.max(height, 0.12), -0.5})
    sun.light.intensity = 3 * day
    sun.light.color = {1, 0.6 + 0.35 * math.max(height, 0), 0.35 + 0.5 * math.max(height, 0)}
    sky.sky.intensity = 0.02 + 0.7 * day
    lamp.light.intensity = 3 * (1 - day)
    for _, w in ipairs(windows) do w.mesh_instance.hidden = day > 0.8 end
end
