#include <stdint.h>
extern uint32_t __StackTop;
extern void _start(void);
void Reset_Handler(void);
void Reset_Handler(void)
{
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20; /* the floating-point unit */
    __asm__ volatile("dsb\n isb");
    _start();
}
static void hang(void) { for (;;) {} }
__attribute__((section(".vectors"), used)) static const void *const vectors[] = {
    &__StackTop, (void *)Reset_Handler, (void *)hang, (void *)hang, (void *)hang, (void *)hang, (void *)hang
};
