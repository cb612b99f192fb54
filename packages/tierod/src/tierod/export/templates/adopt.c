static void PREFIX_adopt(PREFIX_state_t *x, const PREFIX_real_t a[COUNTU])
{
    uint16_t from[COUNTU];
    uint16_t needed[COUNTU];
    uint16_t left = 0U;

    for (uint16_t i = 0U; i < COUNTU; i++) {
        from[i] = i;
        needed[i] = 0U;
    }
    for (uint16_t i = 0U; i < COUNTU; i++) {
        if ((a[i] >= ZERO) && (a[i] < LIMIT)) {
            from[i] = (uint16_t)a[i];
        }
        if (from[i] != i) {
            needed[from[i]]++;
            left++;
        }
    }
    /* A lane whose state no other one still takes over is overwritten first. */
    for (uint16_t n = 0U; (n < COUNTU) && (left > 0U); n++) {
        for (uint16_t i = 0U; i < COUNTU; i++) {
            if ((from[i] != i) && (needed[i] == 0U)) {
                x->lanes[i] = x->lanes[from[i]];
                needed[from[i]]--;
                from[i] = i;
                left--;
            }
        }
    }
    /* What is left are lanes that exchange their states in a circle. */
    for (uint16_t i = 0U; (i < COUNTU) && (left > 0U); i++) {
        if (from[i] != i) {
            uint16_t to = i;

            x->kept = x->lanes[i];
            for (uint16_t n = 0U; (n < COUNTU) && (from[to] != i); n++) {
                const uint16_t next = from[to];

                x->lanes[to] = x->lanes[next];
                from[to] = to;
                to = next;
                left--;
            }
            x->lanes[to] = x->kept;
            from[to] = to;
            left--;
        }
    }
}
