-- 10 000 entities that a scenario sets every step, in one of the ways that there are: --set param.way=field …
-- The row `scenario` of --profile table is what it costs; `empty` is what a step costs in which nothing is set.
local way = kandil.param("way", "assign")
local count = kandil.param("count", 10000)
local sin = math.sin

kandil.scene { size = {16, 16}, fps = 60, gi = "none" }
local all, x, y = {}, {}, {}
for i = 1, count do
    x[i], y[i] = (i % 100) * 0.1, (i // 100) * 0.1
    all[i] = kandil.spawn { transform = { position = {x[i], y[i], 0} } }
end

local ways = {
    empty = function(t) end,
    compute = function(t) local sum = 0 for i = 1, count do sum = sum + sin(t + i) end end,
    assign = function(t) for i = 1, count do all[i].transform = { position = {x[i], y[i], sin(t + i)} } end end,
    field = function(t) for i = 1, count do all[i].transform.position = {x[i], y[i], sin(t + i)} end end,
    set = function(t) for i = 1, count do all[i]:set("transform.position", {x[i], y[i], sin(t + i)}) end end,
    part = function(t) for i = 1, count do all[i]:set("transform.position.z", sin(t + i)) end end,
    turn = function(t) for i = 1, count do all[i].transform.rotation_deg = {0, 90 * sin(t + i), 0} end end,
    get = function(t)
        for i = 1, count do
            local p = all[i]:get("transform.position")
            p[3] = sin(t + i)
            all[i]:set("transform.position", p)
        end
    end,
    change = function(t)
        for i = 1, count do
            local transform = all[i].transform
            local p = transform.position
            p[3] = sin(t + i)
            transform.position = p
        end
    end,
    query = function(t)
        for e, transform in kandil.query("transform") do transform.position = {t, sin(t), 0} end
    end,
    query_part = function(t)
        for e, transform in kandil.query("transform") do e:set("transform.position.z", sin(t)) end
    end,
    query_change = function(t)
        for e, transform in kandil.query("transform") do
            local p = transform.position
            p[3] = sin(t + p[1])
            transform.position = p
        end
    end,
    kept = function(t) end -- below: a handle of the component, got once
}

if way == "kept" then
    local transforms = {}
    for i = 1, count do transforms[i] = all[i].transform end
    ways.kept = function(t) for i = 1, count do transforms[i].position = {x[i], y[i], sin(t + i)} end end
end
kandil.update = ways[way]
