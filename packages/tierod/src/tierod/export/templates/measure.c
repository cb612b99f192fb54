#define SYST_CSR (*(volatile unsigned *)0xE000E010u)
#define SYST_RVR (*(volatile unsigned *)0xE000E014u)
#define SYST_CVR (*(volatile unsigned *)0xE000E018u)
#define INSTRUCTIONS_PER_TICK 40u /* 25 MHz beside one instruction in a nanosecond */
#define PAINTED 16384u

static unsigned char *below(void)
{
    unsigned char here;
    unsigned char *volatile place = &here;
    return place;
}

__attribute__((noinline)) static void paint(void)
{
    volatile unsigned char *place = below() - 64;
    for (unsigned k = 0; k < PAINTED; k++) { place[-(int)k] = 0xA5u; }
}

__attribute__((noinline)) static unsigned depth(unsigned char *top)
{
    volatile unsigned char *lowest = below() - 64 - PAINTED + 256;
    while (*lowest == 0xA5u) { lowest++; }
    return (unsigned)(top - lowest);
}

int main(void)
{
    static OUTPUT_T output;
    unsigned long total = 0, most = 0, deepest = 0;

    begin();
    SYST_RVR = 0xFFFFFFu;
    SYST_CVR = 0u;
    SYST_CSR = 5u;
    for (int k = 0; k < STEPS; k++) {
        double row[INPUTS + 1];
        SAMPLE_T sample;
        for (int i = 0; i < INPUTS; i++) { row[i] = (double)drive[k * INPUTS + i]; }
        sample = taken(row);
        paint();
        const unsigned before = SYST_CVR;
        STEP(&constants, &state, &sample, &output);
        const unsigned spent = (before - SYST_CVR) & 0xFFFFFFu;
        const unsigned used = depth(below());
        total += spent;
        most = (spent > most) ? spent : most;
        deepest = (used > deepest) ? used : deepest;
    }
    printf("mean %.1f most %lu stack %lu state %u constants %u\n", (double)total * INSTRUCTIONS_PER_TICK / STEPS,
           most * INSTRUCTIONS_PER_TICK, deepest, (unsigned)sizeof state, (unsigned)sizeof constants);
    return 0;
}
