// The one door to the view library.
export { html, render, Component, createContext, useState, useReducer, useEffect, useLayoutEffect, useRef, useMemo, useCallback, useContext, useErrorBoundary } from "./vendor/htm-preact.js";
